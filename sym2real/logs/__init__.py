"""Measured logs: CSV and Parquet, recordings of others, mapped by a log specification, looked into by inspection."""

from sym2real.logs.draft import Finding
from sym2real.logs.inspection import Inspection, inspect_logs
from sym2real.logs.reader import read_log, read_logs
from sym2real.logs.specification import SPECS, LogSpec, load_spec
from sym2real.logs.standard import with_header
from sym2real.logs.writer import write_log

__all__ = [
    "SPECS",
    "Finding",
    "Inspection",
    "LogSpec",
    "inspect_logs",
    "load_spec",
    "read_log",
    "read_logs",
    "with_header",
    "write_log",
]
