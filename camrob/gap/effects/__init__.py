"""The library of effects, one file each: a module of this package that holds an `EFFECT` takes part."""
