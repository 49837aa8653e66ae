"""The kinds of probes, one in each file: what a case says of it, its columns and units, its place, and its values.

A file is named after the `kind` of its class, with _probe behind it where another module has that name. It is found by
this name (case.probes.class_of) when a case names its kind, and so starts neither MPI nor numba when it is imported.
"""
