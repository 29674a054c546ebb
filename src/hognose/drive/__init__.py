"""Drives: CANopen, the executor, its record, emulated hardware."""
