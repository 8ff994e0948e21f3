"""Chen and Tsai, Contouring control of a parallel mechanism based on equivalent errors, 2008."""
