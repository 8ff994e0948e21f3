"""Plain C99 of what gough computes: kinematics, dynamics, controllers, observers."""
