"""Measured logs: CSV and Parquet, recordings of others, mapped by a log specification, looked into by inspection."""

from sym2real.logs.draft import Finding as Finding
from sym2real.logs.inspection import Inspection as Inspection, inspect_logs as inspect_logs
from sym2real.logs.reader import read_log as read_log, read_logs as read_logs
from sym2real.logs.specification import SPECS as SPECS, LogSpec as LogSpec, load_spec as load_spec
from sym2real.logs.standard import with_header as with_header
from sym2real.logs.writer import write_log as write_log
