"""What accuracy costs in time, knob by knob, for one scene on one machine in one run."""
