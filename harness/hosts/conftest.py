"""Its folder is on the path of the tests of all hosts, which import its modules."""
