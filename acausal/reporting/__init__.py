"""A report about a model and its simulation as one web page."""
