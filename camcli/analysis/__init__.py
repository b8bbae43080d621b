"""One file per question; plain values in, frozen results out. No drawing, no CLI, no scene."""
