"""The command line: load a scene, analyse it, write artefacts. One thin file per command."""
