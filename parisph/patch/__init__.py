"""Patch tests: what operators make of a field whose derivatives are known, on particles of the unit square or cube."""
