"""Models composed in Python: the same syntax trees as those of a text, hence the same compiler."""
