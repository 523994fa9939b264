"""Readers of the programs of Siemens and Heidenhain, and what Autodesk's posts write in their own way."""
