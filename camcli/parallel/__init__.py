"""Work in pieces: threads or processes that run them, and a journal that keeps them."""

from camcli.parallel.pieces import Codec, Shard, ShardDone, Work
from camcli.parallel.threads import in_threads, thread_count

__all__ = ["Codec", "Shard", "ShardDone", "Work", "in_threads", "thread_count"]
