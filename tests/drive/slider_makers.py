"""Executors with a slider on an emulated serial board, in simulated time."""

from drive_makers import Rig, boards, network_of

from hognose.drive.emulator.board_line import LocalLine
from hognose.drive.serial_slider.adapter import SliderBus

NODE, SLIDER = 126, 36
NAME = "the slider (board at socket://127.0.0.1:1): "


def rig_of(kind="epos2", **given):
    return Rig(boards(), network_of(boards(), kind, slider="serial"), **given)


def board(rig):
    assert rig.emulator.board is not None
    return rig.emulator.board


def bus(rig):
    assert isinstance(rig.bus, SliderBus)
    return rig.bus


def line(rig):
    found = bus(rig).link.line
    assert isinstance(found, LocalLine)
    return found
