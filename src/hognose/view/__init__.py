"""The name of `hognose.report` in version 0.1: its modules can be imported from here for one version more."""

import warnings

import hognose.report

warnings.warn("hognose.view is called hognose.report now", DeprecationWarning, stacklevel=2)
__path__ = hognose.report.__path__
