"""What happened in a run, cycle by cycle: written while it goes on, read also if it was cut off."""

from hognose.drive.record.messages import CycleRow, Event
from hognose.drive.record.reader import Cycles, Image, Record, read_record
from hognose.drive.record.recover import recover
from hognose.drive.record.writer import RecordWriter

__all__ = ["CycleRow", "Cycles", "Event", "Image", "Record", "RecordWriter", "read_record", "recover"]
