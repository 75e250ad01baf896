"""Classes that put the law into programs with a Python interface."""
