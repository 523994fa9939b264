MODULE Bracket_7
    ! Made by camrob, rounded to 3 decimals (mm), 8 (q1..q4), 4 (deg), 4 (eax)
    ! made by hand; ueber {all}
    PERS tooldata t_Bracket_7:=[TRUE,[[0.00000,0.00000,200.00000],[0.00000000,1.00000000,0.00000000,0.00000000]],[38.500,[0.000,-20.250,300.000],[1,0,0,0],0,0,0]];
    PERS tooldata t2_Bracket_7:=[TRUE,[[10.00000,-20.50000,150.00000],[0.70710678,0.00000000,0.70710678,0.00000000]],[21.000,[0.000,0.000,150.000],[1,0,0,0],0,0,0]];
    PERS wobjdata w_Bracket_7:=[FALSE,FALSE,"STN1",[[0,0,0],[1,0,0,0]],[[100.00000,0.00000,50.00000],[0.70710678,0.00000000,0.00000000,0.70710678]]];
    CONST zonedata z_Bracket_7:=[FALSE,0.500,0.500,0.500,0.0500,0.500,0.0500];
    CONST speeddata j_Bracket_7:=[500.000,50.000,400.000,20.000];
    PROC main()
        ActUnit STN1;
        ActUnit TRACK1;
        PDispOff;
        EOffsOff;
        ConfJ\On;
        ConfL\Off;
        SingArea\Off;
        CirPathMode\ObjectFrame;
        AccSet 100,100;
        VelSet 100,5000;
        PathAccLim TRUE\AccMax:=2.0000,TRUE\DecelMax:=2.0000;
        SetDO doRunning,1;
        MoveAbsJ [[0.0000,-15.0000,20.0000,0.0000,55.0000,0.0000],[0.0000,9E9,1200.0000,9E9,9E9,9E9]]\NoEOffs,j_Bracket_7,fine,t_Bracket_7\WObj:=w_Bracket_7;
        SetAO aoSpindle,12000/2400;
        SetDO doSpindle,1;
        WaitTime\InPos,3;
        MoveJ [[100.000,-20.000,300.500],[0.00000000,1.00000000,0.00000000,0.00000000],[-2,2,-3,1],[-45.5000,9E9,1200.2500,9E9,9E9,9E9]],j_Bracket_7,fine,t_Bracket_7\WObj:=w_Bracket_7;
        ! ==== rough
        MoveL [[100.000,-20.000,10.000],[0.00000000,1.00000000,0.00000000,0.00000000],[-1,1,0,0],[-45.5000,9E9,1200.2500,9E9,9E9,9E9]],[200.000,200.000,5000,1000],fine,t_Bracket_7\WObj:=w_Bracket_7;
        WaitTime\InPos,1.250;
        ! a remark ! MoveL p1
        MoveL [[50.000,0.000,10.000],[0.70710678,0.00000000,0.00000000,0.70710678],[-2,0,-1,2],[-45.0000,9E9,1200.0000,9E9,9E9,9E9]],[8.333,200.000,5000,1000],z_Bracket_7,t_Bracket_7\WObj:=w_Bracket_7;
        MoveC [[60.000,10.000,10.000],[0.70710678,0.00000000,0.00000000,0.70710678],[0,2,3,0],[-44.0000,9E9,1200.0000,9E9,9E9,9E9]],[[50.000,20.000,10.000],[0.70710678,0.00000000,-0.70710678,0.00000000],[0,-2,3,5],[-43.0000,9E9,1200.0000,9E9,9E9,9E9]],[25.000,200.000,5000,1000],fine,t_Bracket_7\WObj:=w_Bracket_7;
        SetDO doSpindle,0;
        ToolChange 2;
        MoveJ [[50.000,20.000,200.000],[1.00000000,0.00000000,0.00000000,0.00000000],[0,0,0,4],[-43.0000,9E9,1200.0000,9E9,9E9,9E9]],j_Bracket_7,fine,t2_Bracket_7\WObj:=w_Bracket_7;
        MoveL [[50.000,20.000,10.000],[1.00000000,0.00000000,0.00000000,0.00000000],[0,0,0,4],[-43.0000,9E9,1200.0000,9E9,9E9,9E9]],[25.000,200.000,5000,1000],fine,t2_Bracket_7\WObj:=w_Bracket_7;
        ! coolant_off: the cell has no lines for it
        MoveAbsJ [[0.0000,-15.0000,20.0000,0.0000,55.0000,0.0000],[0.0000,9E9,1200.0000,9E9,9E9,9E9]]\NoEOffs,j_Bracket_7,fine,t2_Bracket_7\WObj:=w_Bracket_7;
        SetDO doRunning,0;
    ENDPROC
ENDMODULE
