"""Prints what python3-rosbag, a reader that is not ours, finds in a bag: JSON, one object for each topic.

usage: read_bag.py BAG [reindex]
"""
import json
import math
import sys
import warnings

import rosbag

warnings.simplefilter("error")  # rosbag warns where a definition and its MD5 sum do not belong together


def plain(value):
    if isinstance(value, bytes):
        return len(value)
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)  # JSON has no word for it
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if hasattr(value, "to_nsec"):
        return value.to_nsec()
    if hasattr(value, "__slots__"):
        return {name: plain(getattr(value, name)) for name in value.__slots__}
    return value


if "reindex" in sys.argv:
    with rosbag.Bag(sys.argv[1], "a", allow_unindexed=True) as bag:
        for _ in bag.reindex():
            pass

topics = {}
with rosbag.Bag(sys.argv[1]) as bag:
    for topic, message, time in bag.read_messages():
        entry = topics.setdefault(topic, {"type": message._type, "count": 0})
        entry["count"] += 1
        entry["last_ns"] = time.to_nsec()
        entry["last"] = plain(message)
print(json.dumps(topics))
