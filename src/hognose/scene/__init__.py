"""What surrounds the arm: obstacles as triangle meshes, the distance tree, clearance."""

from hognose.scene.answers import Clearance, Distances, Witness
from hognose.scene.imports.imported import Mesh, Points
from hognose.scene.moving import MovingObstacle
from hognose.scene.obstacle import ObstacleModel
from hognose.scene.scene import Scene
from hognose.scene.shapes.obstacles import (
    Board,
    Box,
    Cylinder,
    FaceHole,
    Hole,
    Obstacle,
    Pipe,
    Sphere,
    Tank,
)

__all__ = [
    "Board",
    "Box",
    "Clearance",
    "Cylinder",
    "Distances",
    "FaceHole",
    "Hole",
    "Mesh",
    "MovingObstacle",
    "Obstacle",
    "ObstacleModel",
    "Pipe",
    "Points",
    "Scene",
    "Sphere",
    "Tank",
    "Witness",
]
