#!/bin/sh
. ${R}etc/init.d/rc.mc_defaults
if [ $A = yes ]
then
	param set-default MC_PITCH_P 6.5 # pitch
fi
export PX4_PARAM_SYS_AUTOSTART=4001
param set CAL_ACC0_ID ${ID}
