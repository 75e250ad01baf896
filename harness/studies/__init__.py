"""Studies with the law: the paper, accuracy, speed, stability, and the pictures of the docs."""
