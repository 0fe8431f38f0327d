#!/bin/sh
# A small picture for the routine downlink.
exec sleep 20
