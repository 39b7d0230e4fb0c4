"""From a wish to designs: what a timer is to do, and the escapements that do it best."""
