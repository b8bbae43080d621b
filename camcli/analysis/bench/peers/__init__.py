"""General-purpose integrators on the cam and follower, driven as a careful user would.

They share all that is not integration (`world`), and nothing with the kernel. What care means:

* A flight long enough is integrated in (q, v), whose right-hand side has no breakpoints. One that
  falls back within GAP_BELOW of a turn is integrated in the gap y = q - c and u = y' up to the next
  breakpoint of the cam, because q - c of a late chatter bounce is below the rounding of q.
* A step may enter the cam and leave it again without a change of sign of the gap at its ends; the
  methods with their own event search therefore also stop where the gap has a minimum.
* A contact must not fire again as the flight it starts leaves: the first step ends at half the
  ballistic time of the flight, or a part of it is flown by an integrator without events (heyoka,
  whose detection may miss a contact when the gap starts at zero).
* Chatter is closed by its first-order map, 2 r u / ((1 - r) a) after an impact at u < 0 with a < 0,
  once that is below the chatter tolerance; the follower then rests until a becomes positive.
* Every run has a budget of seconds and impacts: Radau at 1e-6 makes tens of thousands of impacts
  at 190 rpm where there are some fifty in a turn.
"""
