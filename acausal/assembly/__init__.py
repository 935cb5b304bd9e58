"""Families and a layout become one DAE problem with native callbacks."""
