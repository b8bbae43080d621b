"""Files a run leaves behind: CSV, pictures and the run record, each written whole or not at all."""
