"""Bodies, friction laws and the small linear algebra that equations of motion need."""
