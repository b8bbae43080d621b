"""The table of extreme cases, one function per row, grouped by what is extreme."""
