"""Words of the program: quantities with their symbols and units, and sentences made from values."""
