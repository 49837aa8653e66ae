"""Numbers that limit the time step (methods.timestep), in a file that estimates can import without MPI."""

BRISK = 1.5    # tuned 0.75 to 3: factor of the largest acceleration, up to the body force; measured
IMPACT = 1.25    # tuned 0.625 to 2.5: factor of the rms acceleration in an impact; measured
# The mean of dt sqrt(2 S:S) over the fluid. Particles move along straight lines in a step, so the volume errs by the
# square of the strain. In the second splash of the dam break at H/s = 40, nine starts, it is too small by 1.06 to
# 1.30 % without this limit, by .74 to 1.07 % with it, and by .76 to 1.14 % with a fixed step of .004 (measured while
# calm fluid was kept at its density, not only without voids).
STRAIN = 0.015    # tuned 0.0075 to 0.03: mean strain of a step of violent flow; measured
# In waves, by the largest rate of the last waves. The mean level drifts in proportion to it: a standing wave with a =
# .05 d, kd = pi and d/s = 10 rises by 3 % of a in 60 periods with it, by 8 % with twice the step.
WAVE_STRAIN = 0.007    # tuned 0.0035 to 0.014: mean strain of a step of waves; measured
# A short rough moment must not stop the run.
WAVE_LEAST = 0.1    # tuned 0.05 to 0.2: least part of the longest step of waves, by strain; judged
