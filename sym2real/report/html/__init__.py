"""The report that people look at: one HTML file, offline."""
