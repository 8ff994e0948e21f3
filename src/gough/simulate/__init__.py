"""The plant, its drives and sensors, the tick that joins them to a controller, and the run."""
