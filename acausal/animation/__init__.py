"""Animations: shapes of components over time, as a web page, GIF or MP4."""
