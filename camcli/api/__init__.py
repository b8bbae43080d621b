"""The library: a scene in, a result with tables, a summary, pictures and a `save` out."""
