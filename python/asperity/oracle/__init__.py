"""Independent writings of the law that the library is compared with; they use nothing of it."""
