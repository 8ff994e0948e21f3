"""Machines: coordinates, kinematics and equations of motion of each kind, and their data sheets."""
