"""Work in pieces: threads or processes that run them, and a journal that keeps them."""

from camcli.parallel.pool import in_threads, thread_count
from camcli.parallel.work import Codec, Shard, ShardDone, Work

__all__ = ["Codec", "Shard", "ShardDone", "Work", "in_threads", "thread_count"]
