"""Robots and motion capture: links, safety, recording and launch scripts. It imports sym2real, never the reverse."""
