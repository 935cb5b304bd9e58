"""Classes with their modifications become class templates, one for every distinct structure."""
