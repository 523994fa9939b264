"""How much the data speak for each set of effects, on samples that took part and on withheld ones."""
