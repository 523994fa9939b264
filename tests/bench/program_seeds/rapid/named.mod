MODULE named
PERS tooldata mill:=[TRUE,[[165,0,405.788],[0,0.96592583,0,-0.25881905]],[38.5,[40,0,180],[1,0,0,0],0,0,0]];
PERS tooldata ball:=[TRUE,[[152.5,4,380],[0.07956538,0.93238991,0.21193235,-0.28178552]],[37.25,[38,0,172],[1,0,0,0],0,0,0]];
PERS wobjdata part:=[FALSE,FALSE,"STN1",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
CONST zonedata near:=[FALSE,0.5,0.5,0.5,0.05,0.5,0.05];
CONST speeddata joints:=[500,50,500,20];
CONST speeddata cut:=[20,100,5000,1000];
CONST jointtarget home:=[[0,-15,20,0,55,0],[0,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget above:=[[-100,-50,300],[0.25827583,0,0,-0.96607122],[-1,0,-1,0],[3.3302,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget low:=[[-100,-50,245],[0.10356782,0,0,-0.99462239],[-1,0,-2,0],[62.9696,9E9,9E9,9E9,9E9,9E9]];
VAR num step:=4;
VAR speeddata slow:=[30,100,5000,1000];
PROC main()
ActUnit STN1;
PDispOff;
EOffsOff;
ConfJ\On;
ConfL\Off;
SingArea\Off;
CirPathMode\ObjectFrame;
AccSet 100,100;
VelSet 100,5000;
PathAccLim TRUE\AccMax:=2,TRUE\DecelMax:=2;
MoveAbsJ home\NoEOffs,joints,fine,mill\WObj:=part;

MoveJ above,joints,fine,mill\WObj:=part;
MoveL low,slow,fine,mill\WObj:=part;
MoveL Offs(low,10,0,-3),slow,fine,mill\WObj:=part;
MoveL RelTool(low,0,5,-2),slow,near,mill\WObj:=part;
MoveL Offs(RelTool(low,0,0,-5),step,1,0),slow,fine,mill\WObj:=part;
side;
MoveL low,slow,fine,mill\WObj:=part;
side;
ENDPROC
PROC side()
VAR num step:=8;
MoveL Offs(low,step,step,0),cut,fine,mill\WObj:=part;
inner;
ENDPROC
LOCAL PROC inner()
CONST speeddata cut:=[10,100,5000,1000];
MoveL Offs(low,0,3,step),cut,fine,mill\WObj:=part;
RETURN;
MoveL above,cut,fine,mill\WObj:=part;
ENDPROC
ENDMODULE
