"""Files for a host program to start from, `asperity export`."""
