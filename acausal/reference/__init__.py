"""The generated reference: classes of the library as pages with symbols and mathematics."""
