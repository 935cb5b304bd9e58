"""Class definitions, scopes and the library: where text and Python meet."""
