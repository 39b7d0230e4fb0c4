"""From a requirement to designs: the task of a timer, and the escapements that do it best."""
