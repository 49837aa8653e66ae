"""The kinds of probes, one in each file: its fields in a case, its columns and units, its place, and its values.

A file is named after the `kind` of its class, with _probe added if another module has that name. case.probes.class_of
finds it by this name while a case is read, so it starts neither MPI nor numba when it is imported.
"""
