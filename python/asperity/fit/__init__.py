"""Parameters of the law from shear-box records, `asperity fit`."""
