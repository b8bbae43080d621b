"""Work in pieces: threads or processes that run them, and a checkpoint that keeps them."""

from camcli.parallel.checkpoint import Checkpoint
from camcli.parallel.threads import in_threads, memory, thread_count
from camcli.parallel.work import Codec, Shard, ShardDone, Work

__all__ = [
    "Checkpoint", "Codec", "Shard", "ShardDone", "Work", "in_threads", "memory", "thread_count",
]  # fmt: skip
