"""Material blocks for the input of host programs, `asperity card`."""
