"""A run is followed while it goes on: its record's messages, by whom has the token, on this machine alone."""

from hognose.drive.live.address import Address, address_of, newest_addresses
from hognose.drive.live.following import Following
from hognose.drive.live.followed import followed
from hognose.drive.live.server import Limits, Live

__all__ = ["Address", "Following", "Limits", "Live", "address_of", "followed", "newest_addresses"]
