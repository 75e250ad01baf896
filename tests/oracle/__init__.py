"""Independent implementations of the law for comparison; they use nothing of the library."""
