"""cam schema"""

import json

from camcli.cli.init import WITHOUT
from camcli.cli.options import Request

__all__ = ["WITHOUT", "schema"]


def schema(request: Request) -> int:
    """Print the scene's JSON Schema, for editors.

    Examples:
      cam schema > schema.json                 for an editor

    -o DIR also writes it there, as schema.json.
    """
    from camcli.output.run_folder import run_folder
    from camcli.scene import json_schema

    text = json.dumps(json_schema(), indent=2) + "\n"
    if request.out is not None and not request.dry_run:
        with run_folder(request.out) as store:
            store.write_text("schema.json", [text])
            store.commit()
    print(text, end="")
    return 0
