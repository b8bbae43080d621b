"""What `cam rerun` says of files made again."""

SAME, OTHER, MISSING = "same bytes", "other bytes", "not made"
CHANGED = "same bytes, but not those of the file beside the record"
OTHER_PROGRAM = "the record is of another version of this program"
SAME_TROUBLE = "some rows are in trouble, as they were in the run: their column status says which"
ONLY_PICTURES = "only pictures differ: their bytes are the same on the same installation alone"


def rerun_title(command: str, same: bool) -> str:
    """The title of the artefacts."""
    return f"cam {command} again: {'the same bytes' if same else 'bytes differ'}"
