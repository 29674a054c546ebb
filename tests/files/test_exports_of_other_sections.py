"""What is exported of arms whose sections are no rigid links."""

import numpy as np
import pytest
from robot_oracles import robot_of

import hognose
from hognose.errors import InputError
from hognose.files.exports.mjcf import bare, mjcf
from hognose.files.exports.subject import Subject
from hognose.files.exports.urdf import urdf
from hognose.mechanics import why_unknown


@pytest.fixture(scope="module")
def arcs():
    part = hognose.load_robot("sjtu-25dof").spec.section[0].model_dump()
    return robot_of([part | {"kind": "arc", "half_lengths": None}])


@pytest.mark.parametrize(("make", "model"), [(mjcf, "MuJoCo"), (bare, "MuJoCo"), (urdf, "URDF")])
def test_models_of_rigid_links_are_refused(arcs, make, model):
    with pytest.raises(InputError, match=f"a model for {model} has one universal joint and one rigid link a section"):
        make(Subject(arcs))


def test_mechanics_are_said_not_to_be_known(arcs):
    mechanics = hognose.load_robot("sjtu-25dof").spec.cables
    arm = arcs.from_spec(arcs.spec.model_copy(update={"cables": mechanics}))
    assert "rigid links with one universal joint each so far" in why_unknown(arm)
    assert np.isfinite(arm.straight_cable_lengths).all()
