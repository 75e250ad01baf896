"""Page in the browser with sliders for constants, pattern and load path."""
