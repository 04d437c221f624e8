"""One training: its recipe, its run folder, the training loop, and the page that shows progress."""
