"""Before metal is cut: what a program asks of a machine, feeds that it can follow, and where to clamp the work."""






