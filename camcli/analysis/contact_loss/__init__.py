"""Where contact is lost: detachment, chatter accumulation, the spring that holds the follower."""
